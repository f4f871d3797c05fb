"""Where the twin and a recording part, which effect explains it, how far it shrinks, which test comes next."""
