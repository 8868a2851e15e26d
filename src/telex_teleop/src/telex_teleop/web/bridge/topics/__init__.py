"""Topics of clients: advertise, publish and subscribe; which commands are obeyed."""
