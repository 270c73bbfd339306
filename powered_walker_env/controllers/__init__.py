"""What decides the control of a stride: policies of environments and of the stride map."""
