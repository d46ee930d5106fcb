"""What is simulated: joint, body, loads, start, and the geometry of the tilted journal, equations (1)-(3)."""
