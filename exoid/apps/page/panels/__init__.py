"""One module for each panel of the page, called as its script in `static/panels/`: what it asks for, and what it may
have done. Nothing is registered.

`ANSWERS` {address: function(workspace, request)}, `ACTIONS` {name: function(workspace, what was said)}; a dict that
comes back from an action is its answer. A script that exports `draw()` is drawn whenever the state has changed,
into the section of its name: one above the section that it names as `ABOVE`, or one that stands in `index.html`.
"""
