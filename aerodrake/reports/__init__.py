"""What people see of flights and comparisons: tables, figures, pages, and the vehicle in 3-D."""
