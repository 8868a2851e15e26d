"""Control laws and limits of single joints."""
