"""How pictures look: styles, colours, labels, the width of a page, and the last touches before one is saved.

Given: axes, records and systems. Given back: nothing but their looks, and texts.
"""
