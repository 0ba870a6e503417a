"""Footplant enforcement as three papers describe it: Glardon 2006, Kim and Neff 2012, Lyard 2007."""
