"""The paper's figures, made by graphs and checked by numbers."""
