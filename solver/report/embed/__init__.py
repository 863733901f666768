"""What report.html carries inside: arrays, scripts and styles."""
