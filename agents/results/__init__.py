"""Results of benchmarks: plans, the rows that plans ask for, and the figures of rows."""
