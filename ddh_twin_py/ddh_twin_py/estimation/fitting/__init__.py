"""A rig's uncertain quantities fitted to recordings on whole free runs."""
