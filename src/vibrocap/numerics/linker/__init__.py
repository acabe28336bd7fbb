"""Joins the sources of a kernel to one text, of which machine code or plain Python is made."""
