"""The twin as an FMU (FMI 2.0 for co-simulation), compiled: whoever runs it needs no Python."""
