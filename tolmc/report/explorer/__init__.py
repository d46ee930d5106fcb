"""The explorer: the part of a report that answers at once what other nominal values and tolerances would do."""
