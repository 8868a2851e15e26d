"""Services of clients: call_service, advertise_service, and the answers of rosapi."""
