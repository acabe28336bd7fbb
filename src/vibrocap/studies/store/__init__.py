"""The store: the folder in which the results of a study are kept, tile by tile, so that it can resume after anything.

`store` begins, fills and resumes one; it is given arrays and gives back what is still to be done. What is in a folder
is looked at before any library opens it: the study (`record`), the form of the Zarr files (`zarr_form`), and every
chunk when it is read (`chunks`, and for Zarr `checked_store`). `verification` compares all of it with its checksums.
"""
