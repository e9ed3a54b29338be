"""The live twin: the nominal model beside a running drive, and where the gap lies now."""
