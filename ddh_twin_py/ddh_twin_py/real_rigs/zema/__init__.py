"""The hydraulic test rig of ZeMA: four components that degrade."""
