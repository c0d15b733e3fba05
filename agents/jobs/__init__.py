"""Work in processes and on other machines."""
