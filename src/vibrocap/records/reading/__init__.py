"""Reading: from files to records.

Given a path, a reader finds the tables in it (`text`, `arrays`); which column is which quantity, in which unit, is said
or guessed from its name (`columns`, `units`); `readers` puts a `Record` together, or says all that is wrong at once.
"""
