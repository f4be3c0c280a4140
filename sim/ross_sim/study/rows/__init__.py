"""What studies write down: rows, files of rows, and the tables and figures that are made of them."""
