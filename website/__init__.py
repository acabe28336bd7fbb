"""The site of the documentation: `python -m website`, or `make site`.

The pages are those of `docs/`, `examples/` and the root, which stay plain Markdown. `staging` lays them out as a tree
of sources, with the pages that are made here: the gallery, run anew (`gallery`), the commands and the public names
(`reference`), what is taken in besides (`embeds`). Sphinx makes HTML of them as `conf` says, and `links` checks every
link and anchor of what came out.
"""
