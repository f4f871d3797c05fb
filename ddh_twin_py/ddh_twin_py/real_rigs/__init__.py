"""The gap diagnosis on recordings of rigs that are not direct driven units: one package for each rig."""
