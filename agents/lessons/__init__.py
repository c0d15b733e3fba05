"""What is learned for lines beside training: settings that are searched, and decisions that are imitated."""
