"""What `import ecyl_ros as ec` offers: reading, diagnosing and simulating from Python."""
