"""An independent rig: other laws and finer states than the twin's, the same data sheet, faults to hide in it."""
