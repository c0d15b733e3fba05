"""The report: tables, figures and a page, all made from results/*.json."""
