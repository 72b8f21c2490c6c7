"""The figures of the page: ``page`` lists them all, the others draw those of one question each."""
