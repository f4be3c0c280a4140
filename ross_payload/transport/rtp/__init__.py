"""Voices as RTP: what a stream is (SDP), and the receiver that makes sound of the packets that came."""
