"""Reference pages in Markdown, made from what the code uses."""
