"""Additions to viser's page: colours for light and dark, a layout for narrow pages, names of fields for readers."""

from __future__ import annotations

from jawenv.live.keys import script_html

TITLE = "jawenv live"
NOTICE = "Simulated, for research, not a medical device."
NOTICE_HTML = f"""
<p id='notice' style='position:fixed; z-index:9; top:0; left:50%; transform:translateX(-50%); pointer-events:none;
  margin:0; padding:1px 10px; border-radius:0 0 8px 8px; background:var(--live-card, #fff);
  color:var(--live-soft, #5b636e); white-space:nowrap; font:12px/1.5 system-ui,sans-serif'>{NOTICE}</p>
"""
DARK_DIGIT = 9
"""The hotkey by which a browser tells that its reader prefers dark pages; with shift, light ones."""

# The controls of a narrow page stand in a sheet below the jaw, as wide as the page.
STYLE = """
<style>
:root { --live-ink: #222a35; --live-soft: #5b636e; --live-card: #fff; --live-line: #e2ded5; --live-track: #eeebe5;
  --live-remark: #8a4b08; --live-accent: #185c8a; }
[data-mantine-color-scheme=dark] { --live-ink: #e6e8ea; --live-soft: #a9b0b8; --live-card: #25282d;
  --live-line: #3d4147; --live-track: #4a4e55; --live-remark: #f0b45c; --live-accent: #86bfe4; }
.mantine-ScrollArea-viewport > div { padding-right: 8px; }
p > label { color: var(--live-soft); }
.mantine-Button-label, .mantine-Tabs-tabLabel { color: var(--live-accent); }
.mantine-Button-root:not([data-variant=outline]) { background: var(--live-accent) !important; }
.mantine-Button-root:not([data-variant=outline]) .mantine-Button-label { color: var(--live-card); }
.mantine-Notification-description { display: none; }  /* a hint of viser's, which would cover the jaw */
.mantine-Notifications-root { top: 22px !important; }  /* below the notice */
.mantine-Notification-root { padding: 0 4px 0 16px; width: max-content; min-height: 0; box-shadow: none; }
.mantine-Notification-title { font-size: 11px; margin: 0; }
#strip { display: none; }
@media (max-width: 36em) { #strip { display: flex; } }
@media (max-width: 62em) { #posterior th, #score th { white-space: normal !important; } }
@media (max-width: 36em) {
  [style*='position: fixed'][style*='width: 20em'] { width: 100% !important; max-height: 56% !important; }
  [style*='width: 20em'] div[style='width: 20em;'] { width: 100% !important; }
}</style>
"""

_SCHEME = f"""
if (!window.jawenvScheme) {{
  window.jawenvScheme = window.matchMedia('(prefers-color-scheme: dark)');
  const tell = () => document.documentElement.dispatchEvent(new KeyboardEvent('keydown',
    {{key: '{DARK_DIGIT}', code: 'Digit{DARK_DIGIT}', shiftKey: !window.jawenvScheme.matches, bubbles: true}}));
  window.jawenvScheme.addEventListener('change', tell);
  if (window.jawenvScheme.matches) setTimeout(tell, 200);
}}
"""

# viser's sliders, their numbers and its icons have no names that a screen reader could say.
_NAMES = """
if (!window.jawenvNames) {
  const name = (field, words) => field.getAttribute('aria-label') || field.setAttribute('aria-label', words);
  window.jawenvNames = setInterval(() => {
    document.querySelectorAll('p > label').forEach((label) => {
      const row = label.parentElement.parentElement.parentElement;
      row.querySelectorAll('[role=slider], input').forEach((field) => name(field, label.textContent));
    });
    document.querySelectorAll('button').forEach((button) => {
      const icon = button.querySelector('svg');
      if (!icon || button.textContent.trim()) return;
      const kind = /tabler-icon-([a-z-]+)/.exec(icon.getAttribute('class') || '');
      name(button, kind ? kind[1].replaceAll('-', ' ') : 'close');
    });
  }, 1000);
}
"""

SCRIPTS = script_html(_SCHEME) + script_html(_NAMES)
