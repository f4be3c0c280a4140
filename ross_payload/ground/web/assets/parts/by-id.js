/** Payloads that have no place on the page: how many they are, and a way to watch or stop one by its id. */

import { html, nothing } from "../templates.js";
import { ID, payloadAddress } from "../route.js";
import { plural } from "../formatting.js";

export function byId(page) {
  const { fleet, mode } = page.store;
  if (mode === "flight") return nothing;
  const hidden = fleet?.hidden;
  return html`<section class="card" aria-label="By id">
    ${
      hidden?.count
        ? html`<p class="bad" role="status">
            ${plural(hidden.count, "more id")} heard and not shown; the steadiest: ${hidden.ids.join(", ")}. Somebody may be
            making ids up.
          </p>`
        : nothing
    }
    <form @submit=${(event) => submitted(page, event)}>
      <label for="by-id">Payload by id, such as 1-191, even one that is not shown</label>
      <input id="by-id" name="id" pattern=${ID} required autocomplete="off" />
      <button type="submit" value="watch">Watch this id</button>
      <button type="submit" value="stop">Stop this id</button>
    </form>
  </section>`;
}

function submitted(page, event) {
  event.preventDefault();
  const id = new FormData(event.target).get("id");
  if (event.submitter?.value === "stop") page.stop([id]);
  else location.hash = payloadAddress(id);
}
