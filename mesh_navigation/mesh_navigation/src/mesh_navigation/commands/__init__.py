"""The commands plan and go_to, and the node that passes clicked goals on."""
