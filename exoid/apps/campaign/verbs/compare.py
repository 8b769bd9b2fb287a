"""`exoid compare` in a campaign: model against measurement."""

from exoid.apps.campaign.verb import CampaignVerb

VERB = CampaignVerb()
