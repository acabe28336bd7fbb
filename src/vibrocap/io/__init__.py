"""Files of results, written and read back.

Given a motion with its case, a study or a fit, the functions here write NetCDF, CSV, JSON, Excel workbooks or MATLAB
files in full precision; NetCDF and CSV files of a motion carry its case, so that it can be run again. Given a file,
they give back a case, or a table of cases. They know results, not how these were made.
"""
