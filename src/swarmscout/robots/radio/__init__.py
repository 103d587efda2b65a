"""Radios: who hears whom, from where robots truly are."""
