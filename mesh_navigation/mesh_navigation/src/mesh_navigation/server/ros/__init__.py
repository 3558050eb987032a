"""The Move Base Flex server: its actions, services and topics."""
