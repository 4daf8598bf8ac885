"""Grasps as data: taught in simulation, chosen from an estimated pose, carried out and watched."""
