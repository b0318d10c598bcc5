"""That this file exists makes the helpers beside it importable from every room's folder."""
