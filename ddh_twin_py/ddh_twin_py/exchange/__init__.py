"""Files of other tools: tables, bags with the twin's outputs, logs, FMUs, layouts."""
