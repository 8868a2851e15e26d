"""Reports of a person or a class, as HTML pages with figures in SVG."""
