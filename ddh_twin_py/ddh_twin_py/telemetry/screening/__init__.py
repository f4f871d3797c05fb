"""Every sample judged before it is used, and what that found, in words."""
