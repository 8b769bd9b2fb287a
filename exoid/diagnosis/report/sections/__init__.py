"""One module per section; a new file is a new section.

A section has `TITLE`, `ORDER` (its place, small first), and `context(material)`, which returns what its
template of the same name (`<name>.html`) shows, or None when the section has nothing to say. With `APPENDIX = True` it
stands in the appendix, which folds and is printed only where it was opened.
"""
