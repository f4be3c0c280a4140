"""Sessions on disk: recorded while the mission goes on, read again for a replay, and deleted in time.

::

    with Recorder(SessionStore(folder), config.recording, begin) as recorder, in_background(recorder):
        runner.observers.append(recorder)             # Inputs and events
        component.tap(lambda frame: recorder.on_frame(timebase.usec(), frame))
        recorder.record(True)
    Session.open(folder / "0001").inputs(config.audio)
"""
