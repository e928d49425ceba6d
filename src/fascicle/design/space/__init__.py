"""What is wanted and what may be built: tasks, products, splits and sizes."""
