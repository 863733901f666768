"""The members of a sweep, and what the solver reads of them."""
