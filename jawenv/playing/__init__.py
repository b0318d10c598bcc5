"""Agents that move the jaw: their protocol, maneuvers and their player, episodes on many patients."""
