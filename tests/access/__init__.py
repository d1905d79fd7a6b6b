"""Who may do what: the table, the passwords, and whether live sessions keep to it."""
