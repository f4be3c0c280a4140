"""What the page is told in a test, instead of what comes on its socket: any state of a payload, at once."""

from browsing import eventually

HOOK = """(() => {
  globalThis.rossTold = {};
  globalThis.rossSent = [];
  globalThis.WebSocket = class extends globalThis.WebSocket {
    constructor(...address) {
      super(...address);
      globalThis.rossSocket = this;
      this.addEventListener("message", (event) => {
        if (globalThis.rossDeaf && !event.made) return event.stopImmediatePropagation();
        const message = JSON.parse(event.data);
        const sections = { ...globalThis.rossTold[message.type]?.sections, ...message.sections };
        globalThis.rossTold[message.type] = { ...message, sections };
      });
    }
    send(data) {
      globalThis.rossSent.push(JSON.parse(data));
      super.send(data);
    }
  };
})()"""
TELL = """async (messages) => {
  for (const message of messages) {
    const event = new MessageEvent("message", { data: JSON.stringify(message) });
    event.made = true;
    globalThis.rossSocket.dispatchEvent(event);
  }
  for (let frame = 0; frame < 3; frame++) await new Promise((drawn) => requestAnimationFrame(drawn));
}"""
WHOLE = "() => rossTold.payload?.sections.isolation?.length && rossTold.payload.sections.health && rossTold.fleet"
NOBODY = {"holder": None, "name": None, "yours": False}


class MadeTelemetry:
    """A payload's page that is told what a test wants from now on; it begins with what the payload told last."""

    def __init__(self, window, url, width, height):
        self.page = window.new_page()
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.emulate_media(color_scheme="light", reduced_motion="reduce")
        self.page.add_init_script(HOOK)
        window.open(self.page, f"{url}#/payload/1-191")
        self.page.locator("table.sources").wait_for()
        eventually(self.page, lambda: self.page.evaluate(WHOLE))
        told = self.page.evaluate("() => { globalThis.rossDeaf = true; return rossTold; }")
        self._fleet, self._payload = told["fleet"], told["payload"]
        self.sections, self.now = self._payload["sections"], told["payload"]["now"] + 1.0

    def tell(self, sections=None, *, age=0.1, control=NOBODY, fleet=None, refused=None):
        """Tell changes of sections; of one that is a mapping, its changed entries. Returns when it is drawn."""
        changed = {name: self._merged(name, value) for name, value in (sections or {}).items()}
        changed["standing"] = {**changed.get("standing", self.sections["standing"]), "last": self.now - age}
        payloads = [{**each, "last": self.now - age} for each in self._fleet["payloads"]]
        messages = [
            {**self._fleet, "now": self.now, "payloads": payloads, **(fleet or {})},
            {**self._payload, "now": self.now, "heard": None, "sections": {**self.sections, **changed}},
            {"type": "control", **control},
        ]
        self.page.evaluate(TELL, messages + ([{"type": "refused", **refused}] if refused else []))

    def sent(self, kind):
        """How many orders of a kind the page has sent."""
        return self.page.evaluate("kind => rossSent.filter((each) => each.order?.kind === kind).length", kind)

    def _merged(self, name, value):
        before = self.sections.get(name)
        return {**before, **value} if isinstance(before, dict) and isinstance(value, dict) else value
