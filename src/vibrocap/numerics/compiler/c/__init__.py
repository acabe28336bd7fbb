"""Kernels in C: given the text of a kernel, `text` gives functions in C99 with its bits.

`functions` writes the typed tree, `snippets` holds what stands once in a text.
"""
