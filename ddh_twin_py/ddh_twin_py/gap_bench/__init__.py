"""The sealed proof of the gap diagnosis: cases made by the independent plant, run blind, scored."""
