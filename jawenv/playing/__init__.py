"""Who moves the jaw: the protocol of an agent, maneuvers and their player, episodes on many patients."""
