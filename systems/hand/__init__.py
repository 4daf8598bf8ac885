"""The Barrett Hand: transmission, TorqueSwitch, driver."""
