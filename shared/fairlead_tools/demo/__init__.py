"""What ``make demo`` runs: one task through the services, recorded and explained."""
