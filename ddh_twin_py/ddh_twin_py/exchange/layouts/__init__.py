"""Ready layouts of other people's viewers, made from one list of views."""
