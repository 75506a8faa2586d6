"""What flexdyn is compared with: equations, laws and integrations written a second time, without flexdyn."""
