"""The live mission: idle, a task, idle again, until shutdown; orders come with the Inputs.

Between tasks only a `Memory` is kept, so that a recording which begins there can be replayed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from ross_payload.config import Config
from ross_payload.config.parameter_table import changed
from ross_payload.errors import ConfigError, PluginError
from ross_payload.events import (
    Answer,
    Answered,
    Enrolled,
    Event,
    Finished,
    OrientationHeard,
    Outcome,
    SourcesEstimated,
    SourcesReconsidered,
    SourcesTracked,
    State,
)
from ross_payload.interfaces import Input, Mission, Output, Result, VoicePrint
from ross_payload.mission.context import NOTHING, Context, Ended, FrameChanged, Step, exchange
from ross_payload.mission.settings import Settings, Tools
from ross_payload.mission.tasks import WITHOUT_TOOLS, Memory, TaskRefused, perform, refusal
from ross_payload.mission_state import BUSY, is_same_fault
from ross_payload.orders import Cancel, MeasureNoise, Order, Point, Rearm, Set, Shutdown, Stop, Task

FREE = Output(hold=False)  # no task needs the actuator
WELL = 1.0  # [s] without the fault, after which one that was there while nothing turned is over
ANSWERS = {Outcome.FAULT: Answer.FAILED, Outcome.NO_TARGET: Answer.FAILED, Outcome.STOPPED: Answer.CANCELLED}


@dataclass(frozen=True, slots=True)
class Kit:
    """What a task works with; it follows from the configuration."""

    settings: Settings
    tools: Tools


Make = Callable[[Config], Kit]


class LiveSession:
    """One session: its mission, and what it knows between tasks.

    Parameters
    ----------
    config
        What a `Set` order changes.
    make
        Makes settings and tools from a configuration.
    memory
        What an earlier session knew.
    noting
        Wraps the print of a voice that is enrolled on the way, so that what it is asked is recorded.
    """

    def __init__(
        self,
        config: Config,
        make: Make,
        memory: Memory | None = None,
        noting: Callable[[VoicePrint], VoicePrint] = lambda voiceprint: voiceprint,
    ) -> None:
        self.config = config
        self.busy = False  # a task is going on
        self._memory = memory or Memory(starting=True)
        self._stopped, self._starting = self._memory.stopped, self._memory.starting
        self._make = make
        self._noting = noting
        self._enrolled: Enrolled | None = None  # the latest voice: from then on the target
        self._fault = ""
        self._ill: float | None = None  # when a fault was last there that goes away with its cause [s]
        self._broken = False  # a fault has ended a task: it waits for Rearm, or for a task in spite of it
        self._pending = False  # the task to begin with waits for the actuator
        self._waiting: list[Order] = []  # came while no task was going on
        kit = make(config)
        self._context = Context(kit.settings, kit.tools, samples=self._memory.samples)

    @property
    def memory(self) -> Memory:
        """What a session that goes on from here must know, between tasks."""
        samples = self._context.samples
        known = replace(self._memory, stopped=self._stopped, starting=self._starting, pending=self._pending)
        return replace(known, samples=samples)

    @property
    def target(self) -> str:
        """The name of the voice that is sought, empty: nobody's."""
        return self.config.service.target if self._enrolled is None else self._enrolled.name

    def mission(self, first: Task | None = None) -> Mission:
        """Obey orders until `Shutdown`; nothing turns before a task is ordered.

        Prime it with ``next``; then send one Input for every Output. It returns a Result. ``first`` is a task to
        begin with, without being asked, as soon as the actuator is ready; not when something is ordered before.
        """
        self._rest()
        order: Order | None = None if first is None else (yield from self._first(first))
        while not isinstance(order, Shutdown):
            order = (yield from self._task(order)) if isinstance(order, Task) else (yield from self._idle())
        self._answer(order, Answer.ACCEPTED)
        yield Output(tuple(self._context.pending), stop=True)
        return Result(Outcome.STOPPED, "shut down")

    def _first(self, task: Task) -> Step[Task | None]:
        """Wait until the actuator has been found; return the task to begin with, None when it is not to begin."""
        self._pending = True
        yield from self._hop()
        while self._starting and self._fault and not self._ordered():
            yield from self._hop(FREE)
        self._pending = False
        if self._ordered() and not self._stopped:
            self._answer(task, Answer.REFUSED, "something else was ordered before it began")
            return None
        return task

    def _ordered(self) -> bool:
        """Obey changes of settings; tell whether anything else is ordered, or a stop was before."""
        settings = [order for order in self._waiting if isinstance(order, Set)]
        self._waiting = [order for order in self._waiting if not isinstance(order, Set)]
        for order in settings:
            self._change(order)
        return self._stopped or bool(self._waiting)

    def _hop(self, wish: Output = NOTHING) -> Step[Input]:
        """Hear one hop between tasks; what it orders waits for its turn."""
        heard = yield from exchange(self._context, wish)
        self._waiting += heard.orders
        if heard.fault:
            if not is_same_fault(heard.fault, self._fault):
                self._enter(State.FAULT, heard.fault)
            self._ill = None if self._broken else self._context.time
        elif self._ill is not None and (self._starting or self._context.time - self._ill >= WELL):
            self._ill = None
            self._rest("the actuator is ready")  # nothing was turned: what is latched is still a fault
        self._starting = self._starting and bool(heard.fault)
        self._fault = heard.fault
        self._say_known()  # as soon as the frame of its azimuths is back
        return heard

    def _idle(self) -> Step[Order]:
        """Wait for a task or the shutdown; obey everything else, in order."""
        while True:
            if not self._waiting:
                yield from self._hop(FREE)
                continue
            order = self._waiting.pop(0)
            match order:
                case Shutdown():
                    return order
                case Task() if any(isinstance(later, (Stop, Cancel, Shutdown)) for later in self._waiting):
                    self._answer(order, Answer.REFUSED, "cancelled before it began")
                case Point() if any(isinstance(later, Task) for later in self._waiting):
                    pass  # the later one takes its place
                case Task():
                    for other in [later for later in self._waiting if isinstance(later, Task)]:
                        self._waiting.remove(other)
                        self._answer(other, Answer.REFUSED, BUSY)
                    return order
                case Rearm():
                    yield from self._rearm(order)
                case Set():
                    self._change(order)
                case Stop():
                    self._stopped = True
                    self._enter(State.STOPPED, "stopped by command")
                    self._answer(order, Answer.ACCEPTED)
                    yield from self._hop(Output(stop=True))
                case Cancel():
                    self._answer(order, Answer.ACCEPTED, "nothing to cancel")

    def _rearm(self, order: Order) -> Step[None]:
        """Forget the stop, as the guard does; a fault that remains is one that `Home` may clear."""
        self._stopped, self._fault = False, ""
        heard = yield from self._hop(Output(rearm=True))
        if heard.fault:
            self._answer(order, Answer.REFUSED, heard.fault)
        else:
            self._broken, self._ill = False, None
            self._enter(State.IDLE, "re-armed")
            self._answer(order, Answer.ACCEPTED)

    def _task(self, task: Task) -> Step[Order | None]:
        """Perform one task; return the order that ends the session, if any."""
        try:
            old, kit = self._context, self._kit(task)
        except ConfigError as error:  # a plug-in that was changed meanwhile
            self._answer(task, Answer.REFUSED, str(error))
            return None
        self._context = Context(kit.settings, kit.tools, samples=old.samples, last=old.last, pending=old.pending)
        self._context.refusal = self._refusal_meanwhile
        if why := self._refusal(task):
            self._answer(task, Answer.REFUSED, why)
            return None
        self._answer(task, Answer.ACCEPTED)
        for late in [order for order in self._waiting if isinstance(order, Rearm)]:  # not to undo a stop of this task
            self._waiting.remove(late)
            self._answer(late, Answer.REFUSED, BUSY)
        self.busy, self._starting, self._broken, self._ill = True, False, False, None
        try:
            result = yield from self._watched(task)
        except TaskRefused as refused:
            self._close(task, Result(Outcome.FAULT, str(refused)), State.DONE)
        except PluginError as error:  # a separator, an explorer or a network of others
            return (yield from self._end(task, Ended(Outcome.FAULT, str(error))))
        except Ended as ended:
            return (yield from self._end(task, ended))
        else:
            self._close(task, result, State.DONE)
        finally:
            self.busy = False
        return None

    def _refusal_meanwhile(self, task: Task) -> str:
        """Return why a task cannot be begun in the place of the present one, which goes on then; empty when it can."""
        try:
            self._made(task)
        except ConfigError as error:
            return str(error)
        return self._refusal(task)

    def _refusal(self, task: Task) -> str:
        """Return why a task cannot be begun; empty when it can."""
        return refusal(self._context, self._memory, task, stopped=self._stopped, fault=self._fault)

    def _made(self, task: Task) -> Kit:
        """Make what a task works with; one that uses no plug-in may work with what the task before had."""
        try:
            return self._make(self.config)
        except ConfigError:
            if not isinstance(task, WITHOUT_TOOLS):
                raise
            return Kit(self._context.settings, self._context.tools)

    def _kit(self, task: Task) -> Kit:
        kit = self._made(task)
        if self._enrolled is None:
            return kit
        return replace(kit, tools=replace(kit.tools, voiceprint=self._noting(self._enrolled.voiceprint)))

    def _end(self, task: Task, ended: Ended) -> Step[Order | None]:
        """End a task that did not come to its own end; return the order that ends the session, too."""
        result, order = Result(ended.outcome, ended.reason), ended.order
        self._fault = "" if order is not None or isinstance(ended, FrameChanged) else ended.reason
        self._stopped, self._broken = isinstance(order, Stop), bool(self._fault)
        self._close(task, result, State.FAULT if self._fault else State.STOPPED if self._stopped else State.DONE)
        if isinstance(order, (Stop, Cancel)):
            self._answer(order, Answer.ACCEPTED)
        yield from self._hop(Output(halt=not self._stopped, stop=self._stopped))
        return order if isinstance(order, Shutdown) else None

    def _close(self, task: Task, result: Result, state: State) -> None:
        """Say how a task ended."""
        self._waiting += self._context.later
        self._remember(self._context.pending)
        self._say_known()
        self._enter(state, result.reason)
        if not isinstance(task, Point):  # by hand, and no mission
            self._context.publish(Finished(self._context.time, result.outcome, result.reason))
        self._answer(task, ANSWERS.get(result.outcome, Answer.DONE), result.reason)

    def _say_known(self) -> None:
        """Say again what is known where an exploration did not come to its end: orders count by these sources."""
        known, earth = self._memory.estimate, self._context.pointing.earth
        if self._memory.unfinished and known is not None and self._memory.earth == earth:
            self._context.publish(SourcesEstimated(self._context.time, known, rotations=0, final=True, informed=True))
            self._memory = replace(self._memory, unfinished=False)

    def _watched(self, task: Task) -> Step[Result]:
        """Perform a task; remember what it finds out and tell how far it is."""
        step = perform(self._context, self._memory, task)
        output = replace(next(step), hold=True)
        while True:
            self._remember(output.events)
            progress = tuple(
                self._progress(task, event) for event in output.events if isinstance(event, OrientationHeard)
            )
            try:
                output = step.send((yield replace(output, events=output.events + progress)))
            except StopIteration as end:
                if isinstance(task, MeasureNoise):
                    heard = self._context
                    self._memory = replace(
                        self._memory,
                        noise=heard.lead_in,
                        noise_aboard=heard.lead_in_aboard,
                        noise_speeds=heard.lead_in_speeds,
                    )
                result: Result = end.value
                return result

    def _remember(self, events: Iterable[Event]) -> None:
        for event in events:
            if isinstance(event, Enrolled):
                self._enrolled = event
            if isinstance(event, SourcesEstimated):
                self._memory = replace(self._memory, unfinished=not event.final)
            if isinstance(event, SourcesEstimated) and event.final:
                earth, again = self._context.pointing.earth, event.estimate is self._memory.estimate
                explored = not event.informed or (again and self._memory.explored)
                self._memory = replace(self._memory, estimate=event.estimate, earth=earth, explored=explored)
            elif isinstance(event, SourcesTracked | SourcesReconsidered):
                self._memory = replace(self._memory, estimate=event.estimate)

    def _progress(self, task: Task, event: OrientationHeard) -> Answered:
        share = min(event.index / max(self.config.explore.last_rotation, 1), 1.0)
        return Answered(event.time, task.number, Answer.PROGRESS, progress=share)

    def _rest(self, detail: str = "") -> None:
        self._enter(State.STOPPED if self._stopped else State.IDLE, detail)

    def _enter(self, state: State, detail: str = "") -> None:
        self._context.enter(state, detail)

    def _answer(self, order: Order, answer: Answer, reason: str = "") -> None:
        self._context.publish(Answered(self._context.time, order.number, answer, reason))

    def _change(self, order: Set) -> None:
        """Change a setting; the next task begins with it."""
        try:
            self.config = changed(self.config, order.name, order.value)
        except ConfigError as error:
            self._answer(order, Answer.REFUSED, str(error))
        else:
            self._answer(order, Answer.ACCEPTED)
