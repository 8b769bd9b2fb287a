"""The panel of the page that plays a recording through a watch."""
