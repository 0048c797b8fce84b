"""What touches the machine and knows no scenario: errors, files, processes, compiled code."""
