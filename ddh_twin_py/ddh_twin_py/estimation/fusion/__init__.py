"""The temperature filter and what goes into it: prediction, update, start, state on disk, smoothing, looking ahead."""
